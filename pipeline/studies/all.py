"""All studies; a new one is added here."""

from pipeline.errors import ConfigError
from pipeline.studies.differentiators import Differentiators
from pipeline.studies.laws_compared import LawsCompared
from pipeline.studies.paper import PaperAgain
from pipeline.studies.robustness import Robustness
from pipeline.studies.sampled_twisting import SampledTwisting
from pipeline.studies.study import Study
from pipeline.studies.twisting_laws import TwistingLaws

STUDIES: tuple[Study, ...] = (
    PaperAgain(),
    SampledTwisting(),
    TwistingLaws(),
    LawsCompared(),
    Robustness(),
    Differentiators(),
)


def study_named(name: str) -> Study:
    """Find a study.

    Args:
        name: its name.

    Returns:
        The study in the size for its figure.

    Raises:
        ConfigError: if there is none of that name.
    """
    for study in STUDIES:
        if study.name == name:
            return study
    names = ", ".join(study.name for study in STUDIES)
    raise ConfigError(f'no study "{name}"; there are: {names}')
