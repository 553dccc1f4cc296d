"""The inputs of bodies with losses: which model they choose, and what is refused."""

import pytest
from messages import assert_facts

from sweep.errors import RequestError
from sweep.model.bodies.model import BODIES
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec

#: Inputs -> text of the refusal.
REFUSED = {
    "body=ball air_law=moffatt air_viscosity=18e-6 mass=1": "A ball rolls without losses",
    "body=spheroid flattening=0.2 contour_friction=0": "A spheroid rolls without losses",
    "flattening=0.2 contour_friction=10um": "No body with losses takes it",
    "body=torus tube=0.2 flattening=0.2 contour_friction=10um": "has no flattening",
    "body=torus tube=0.2 air_law=moffatt air_viscosity=18e-6 mass=1": "under a flat face, and a torus has none",
    "body=rounded thickness=2 rolling_friction=10um": "no face left to lie on",
    "body=rim thickness=2 fillet=0.5:1:3 rolling_friction=10um": "no face left to lie on",
    "body=rounded rolling_friction=10um": "needs its thickness",
    "body=torus tube=0.2 thickness=0.1 rolling_friction=10um": "has no thickness",
    "body=torus tube=0.2 rolling_friction=2m radius=1m": "shorter than the radius",
    "body=torus tube=0.2 contour_damping=1e-6": "needs the mass",
    "body=torus tube=0.2 rolling_friction=10um fall_tilt=80deg": "flat_tilt, the tilt that counts as flat",
    "body=torus tube=0.2 rolling_friction=10um alpha=1": "alpha is for the thin disk",
    "body=torus tube=0.2 rolling_friction=10um method=exact": "method is rk4",
    "body=torus tube=0.2 rolling_friction=10um path=yes": "path",
}


def spec_of(words, spec="rolling"):
    """Return the spec of command-line words that change a preset."""
    return SweepSpec.from_words(spec, words.split())


def test_what_has_no_losses_is_refused_in_a_sentence():
    """Each refusal says what is wrong and what to do."""
    for words, told in REFUSED.items():
        with pytest.raises(RequestError) as caught:
            spec_of(words)
        assert told in str(caught.value), words
        assert caught.value.hint, words


def test_losses_of_a_ball_leave_nothing_on_the_disk(command, tmp_path):
    """Every command that writes a file refuses them, also on top of a preset or an atlas."""
    assert (
        command("run toy tilt=80deg,81deg precession_rate=20 duration=1ms criterion=aloft:1ms -o toy.nc -q")[
            0
        ]
        == 0
    )
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    for line in (
        "run egg pivoting_friction=10um -o a.nc",
        "run toy body=ball -o a.nc",
        "run egg air_law=moffatt air_viscosity=18e-6 mass=7g -o toy.nc --overwrite",
        "simulate egg offset=0.2 roll_rate=20 pivoting_friction=10um -o a.nc --plot a.png",
        "simulate --from toy.nc tilt=80deg body=ball -o a.nc",
        "explore egg rolling_friction=10um --export a.html",
    ):
        status, _, told = command(line)
        assert status == 2, line
        assert_facts(told, "A ball rolls without losses", "body=torus", "body=arc", "Leave the losses out")
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_words_of_a_body_and_of_losses_choose_both():
    """They may come together, on top of a preset with the other kind, or one after the other."""
    losses, body = "contour_friction=10um", "body=rim thickness=12.8mm fillet=2mm"
    assert spec_of(f"{losses} {body} radius=37.55mm").model is LOSSY_BODIES
    assert spec_of(body, "toy").model is LOSSY_BODIES
    assert spec_of(f"{losses} criterion=aloft:1s", "true_edge").model is LOSSY_BODIES
    torus = spec_of("body=torus tube=0.2")
    assert torus.model is BODIES
    assert torus.replace(rolling_friction="10um").model is LOSSY_BODIES
    disk = spec_of("rolling_friction=10um")
    assert disk.model is LOSSY_DISK
    assert disk.replace(body="torus", tube=0.2).model is LOSSY_BODIES
    again = SweepSpec.from_canonical(spec_of(body, "toy").canonical())
    assert again == spec_of(body, "toy")


def test_the_thin_disk_again():
    """body=disk drops the body and keeps the losses; a torus needs no tube."""
    spec = spec_of("body=rim thickness=12.8mm fillet=2mm", "toy")
    thin = spec.replace(body="disk")
    assert thin.model is LOSSY_DISK
    assert thin.contour_friction == spec.contour_friction
    assert SweepSpec(body="torus", rolling_friction="10um").tube == "none"


def test_the_sample_of_an_audit_is_that_of_its_seed():
    """The seed given to `verify` draws the sample, and the report names it."""
    spec = SweepSpec(body="torus", tube=0.2, rolling_friction="1mm", roll_rate="1:3:5")
    samples = [spec.model.reference(5, seed).sampled for seed in (7, 7, 8)]
    assert_facts(samples[0], "seed 7")
    assert samples[0] == samples[1] != samples[2]


def test_each_set_of_laws_has_its_kernel():
    """The kernels of bodies have the same names as the disk's."""
    spec = spec_of("body=rim thickness=12.8mm fillet=2mm friction=0.5", "toy")
    kernel = spec.model.integrator(spec)
    assert kernel.module == "kernels.lossy_bodies.integrate"
    assert kernel.function == "integrate_dry_bildsten_slipping"
