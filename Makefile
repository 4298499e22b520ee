# Everything goes into .venv; each target installs what it needs first.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
PACKAGES := $(VENV)/.packages
COMPILED := $(VENV)/.compiled
BUILD := build
# With a screen the viewer opens; without one the run is kept for `rerun build/live.rrd`.
VIEW ?= $(if $(DISPLAY)$(WAYLAND_DISPLAY),rerun,$(BUILD)/live.rrd)

# Every start of Python would compile everything anew: seconds, and more in tests.
unexport PYTHONDONTWRITEBYTECODE

.PHONY: packages install live test check bench limits picture layouts clean

packages: $(PACKAGES)

install: $(COMPILED)

$(PACKAGES): pyproject.toml constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Echelon needs Python 3.11 or newer; try: make $(MAKECMDGOALS) PYTHON=python3.12"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes -r constraints.txt
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-deps --editable .
	@touch $@

$(COMPILED): $(PACKAGES)
	$(BIN)/echelon live paper --fast --duration 0.3 > /dev/null # compiles what drives, once
	@touch $@

live: install
	@mkdir -p $(BUILD)
	$(BIN)/echelon live paper --view $(VIEW) --record $(BUILD)/live.mcap --report $(BUILD)/report

test: install
	$(BIN)/python -m tests $(ARGS)

check: packages
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy

# One peer has wheels for some machines only: where it cannot be had, its row is left out.
bench: install
	@mkdir -p $(BUILD)
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check --require-hashes --no-deps \
		-r constraints-bench.txt || echo "pupil-apriltags: no package for this machine"
	$(BIN)/python -m benchmarks $(ARGS)

limits: install
	@mkdir -p $(BUILD)
	$(BIN)/python -m benchmarks.limits

picture: install
	$(BIN)/python docs/picture.py

layouts: install
	$(BIN)/python docs/layouts_picture.py

clean:
	rm -rf $(VENV) $(BUILD) *.egg-info
