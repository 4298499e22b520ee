"""What the certificates say, in words and numbers."""

from collections.abc import Iterator
from math import degrees, inf

from control.conditions import Needs
from control.gains import Certificate, Verdict
from control.laws import Law, is_first_order
from pipeline.certificates import Certificates, Certified, make_certificates, start_states
from pipeline.config import Scenario
from pipeline.finding import Finding
from pipeline.setup import Setup


def certificate_findings(made: Certificates, setup: Setup) -> Iterator[Finding]:
    """What is guaranteed of every follower, what is not, and what would be needed.

    Only gains that do not even do for exact robots on the plan fail a check; what is not
    guaranteed under model errors and pushes is told.

    Args:
        made: the certificates.
        setup: gains and formation.

    Yields:
        Up to four findings a follower, and one for a plan whose velocities jump.
    """
    for certified in made.pairs:
        yield from _of_pair(certified, setup, " between the plan's jumps" * bool(made.jumps.size))
    if made.jumps.size:
        yield _jumps(made)


def broken_gains(scenario: Scenario, setup: Setup) -> tuple[str, ...]:
    """Why gains do not do, even for exact robots.

    Args:
        scenario: with the robots' starts.
        setup: made from it.

    Returns:
        One line for every follower whose gains would fail a check.
    """
    found = certificate_findings(make_certificates(setup, start_states(scenario, setup)), setup)
    return tuple(f"{f.topic}: {f.detail}" for f in found if f.binding and not f.holds)


def _jumps(made: Certificates) -> Finding:
    when = ", ".join(f"{t:.2f}" for t in made.jumps[0])
    v, omega = abs(made.jumps[1:]).max(axis=1)
    detail = (
        f"its velocities jump by up to {v:.2g} m/s, {omega:.3g} rad/s at {when} s: no law keeps "
        "s = 0 through a jump; certificates are for what is between"
    )
    return Finding("smooth plan", False, detail, binding=False)


def _of_pair(certified: Certified, setup: Setup, between: str) -> Iterator[Finding]:
    robot, certificate = certified.pair.follower, certified.certificate
    if certificate is None:
        yield Finding(f"certificate {robot}", False, certified.trouble, binding=False)
        return
    gains = setup.gains[robot]
    planned = certified.pair.leader == setup.formation.root
    whose = "" if planned else f" behind robot {certified.pair.leader}, taken to slide ideally"
    yield Finding(f"omega {robot}", True, _omega(certificate))
    yield Finding(
        f"gains {robot}",
        certificate.exact.holds,
        f"{gains.law.title} for exact robots on this plan{whose}: {_told(certificate.exact)}",
        binding=planned and gains.law != Law.SUPER_TWISTING,
    )
    for topic, verdict, detail in (
        ("certificate", certificate.run, _run(certificate, gains.law, between)),
        ("all of omega", certificate.everywhere, _everywhere(certificate, gains.law, between)),
    ):
        yield Finding(f"{topic} {robot}", verdict.holds, detail, binding=False)


def _omega(certificate: Certificate) -> str:
    (alpha, beta), (width, width_2) = certificate.omega.bounds, certificate.omega.invariant
    return (
        f"|e_l| < {1e3 * alpha:.0f} mm, |e_psi| < {degrees(beta):.1f} deg; Lambda: starts within "
        f"{1e3 * width:.0f} mm, {degrees(width_2):.1f} deg, at this one's rates, stay in it; from "
        f"this one the nominal path keeps {1e3 * certificate.least_distance:.0f} mm from the leader"
    )


def _run(certificate: Certificate, law: Law, between: str) -> str:
    """From this start."""
    error, push = certificate.doubt.model_error, certificate.doubt.push
    told = (
        f"{_word(certificate.run, between)} from this start, model errors of {100.0 * error:.3g} % "
        f"(delta {1.0 - error:.2f}, delta' {1.0 + error:.2f}), pushes of {push:.2f} m/s^2: "
        f"{_rho(certificate.run, law)}{_told(certificate.run)}"
    )
    if certificate.needs is None:
        return told
    return f"{told}; each alone would do: {_needs(certificate.needs)}"


def _word(verdict: Verdict, between: str) -> str:
    return f"guaranteed{between}" if verdict.holds else "not guaranteed"


def _rho(verdict: Verdict, law: Law) -> str:
    if is_first_order(law):
        return ""
    return f"rho {verdict.rho[0]:.2f} m/s^2, {verdict.rho[1]:.2f} rad/s^2; "


def _told(verdict: Verdict) -> str:
    """Gains and what is needed of them, channel by channel."""
    told: dict[tuple[str, str], list[str]] = {}
    for c in verdict.conditions:
        sign = (">" if c.strict else ">=") if c.holds else ("<=" if c.strict else "<")
        gain = f"{c.name.split()[0]} {c.given:g} {sign} {c.needed:.3g}"
        told.setdefault((c.channel, c.unit), []).append(gain)
    return "; ".join(
        f"{', '.join(gains)} {unit}" + (f" ({channel})" if channel != "both" else "")
        for (channel, unit), gains in told.items()
    )


def _needs(needs: Needs) -> str:
    mu, nu = needs.gains or needs.uncoupled
    gains = f"mu {mu:.3g}, nu {nu:.3g}"
    if not needs.gains:
        gains = f"no mu and nu ({gains} if neither channel's control disturbed the other)"
    error, pace, added = needs.model_error, needs.pace, needs.spacing
    return ", ".join((
        gains,
        "no model error" if error is None else f"model errors of {100.0 * error:.2g} %",
        "not even a leader at rest" if pace is None else f"{100.0 * pace:.0f} % of its speed",
        "no wider spacing" if added is None else f"{1e3 * added:.0f} mm more spacing",
    ))  # fmt: skip


def _everywhere(certificate: Certificate, law: Law, between: str) -> str:
    """From every start in Lambda, at any time."""
    verdict = certificate.everywhere
    if law == Law.SUPER_TWISTING:
        return "not guaranteed: Omega does not bound how fast the disturbance changes"
    if max(verdict.rho) == inf:
        return "not guaranteed: Omega reaches the leader, where rho has no bound"
    told = f"{_rho(verdict, law)}{_told(verdict)}"
    return f"{_word(verdict, between)} from every start in Lambda, at any time: {told}"
