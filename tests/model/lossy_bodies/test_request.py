"""The words of bodies with losses: what they choose, and what is refused."""

import numpy as np
import pytest
from messages import assert_facts

from sweep.errors import RequestError
from sweep.model.bodies.model import BODIES
from sweep.model.lossy_bodies.model import LOSSY_BODIES
from sweep.model.lossy_disk.model import LOSSY_DISK
from sweep.request.spec import SweepSpec

#: Words -> what the refusal says.
REFUSED = {
    "body=ball air_law=moffatt air_viscosity=18e-6 mass=1": "under a flat face, and a ball has none",
    "body=ball rolling_friction=10um criterion=aloft:2s duration=5s": "A ball does not fall: by the criterion",
    "body=spheroid flattening=0.2 contour_friction=10um flat_tilt=80deg": "A spheroid does not fall: it rolls on",
    "body=ball offset=0.1 contour_friction=10um": "moments of a ball whose centre of mass is not its centre",
    "body=ball offset=1.1 axial_moment=0.4 transverse_moment=0.4 contour_friction=10um": "lies inside",
    "body=torus tube=0.2 air_law=moffatt air_viscosity=18e-6 mass=1": "under a flat face, and a torus has none",
    "body=rounded thickness=2 rolling_friction=10um": "no face left to lie on",
    "body=rim thickness=2 fillet=0.5:1:3 rolling_friction=10um": "no face left to lie on",
    "body=rounded rolling_friction=10um": "needs its thickness",
    "body=torus tube=0.2 thickness=0.1 rolling_friction=10um": "has no thickness",
    "body=torus tube=0.2 rolling_friction=2m radius=1m": "shorter than the radius",
    "body=torus tube=0.2 contour_damping=1e-6": "needs the mass",
    "body=torus tube=0.2 rolling_friction=10um fall_tilt=80deg": "say flat_tilt, the tilt at which the body",
    "body=torus tube=0.2 rolling_friction=10um alpha=1": "alpha is for the thin disk",
    "body=torus tube=0.2 rolling_friction=10um method=exact": "method is rk4",
    "body=torus tube=0.2 rolling_friction=10um path=yes": "path",
}


def spec_of(words, spec="rolling"):
    """Return the spec of words of a command line, which change a preset."""
    return SweepSpec.from_words(spec, words.split())


def test_what_has_no_losses_is_refused_in_a_sentence():
    """Each refusal says what is wrong and what to do."""
    for words, told in REFUSED.items():
        with pytest.raises(RequestError) as caught:
            spec_of(words)
        assert told in str(caught.value), words
        assert caught.value.hint, words


def test_words_of_a_body_and_of_losses_choose_both():
    """Whether they come together, on a preset that has the others, or one after the other; one kind alone as before."""
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
    """body=disk leaves the body behind and keeps the losses; a torus may come without a tube."""
    spec = spec_of("body=rim thickness=12.8mm fillet=2mm", "toy")
    thin = spec.replace(body="disk")
    assert thin.model is LOSSY_DISK
    assert thin.contour_friction == spec.contour_friction
    assert SweepSpec(body="torus", rolling_friction="10um").tube == "none"


def test_the_sample_of_an_audit_is_that_of_its_seed():
    """The seed that `verify` is given draws the sample, and is told."""
    spec = SweepSpec(body="torus", tube=0.2, rolling_friction="1mm", roll_rate="1:3:5")
    samples = [spec.model.reference(5, seed).sampled for seed in (7, 7, 8)]
    assert_facts(samples[0], "seed 7")
    assert samples[0] == samples[1] != samples[2]


def test_each_set_of_laws_has_its_kernel():
    """The kernels are those of bodies, by the names of the disk's."""
    spec = spec_of("body=rim thickness=12.8mm fillet=2mm friction=0.5", "toy")
    kernel = spec.model.integrator(spec)
    assert kernel.module == "kernels.lossy_bodies.integrate"
    assert kernel.function == "integrate_dry_bildsten_slipping"


def test_balls_and_spheroids_have_one_kernel_with_all_laws():
    """Whatever their laws; and a criterion measures from the pole that a body on its end stands on, start by start."""
    egg = spec_of("pivoting_friction=10um", "egg")
    assert egg.model is LOSSY_BODIES
    lens = spec_of("body=spheroid flattening=0.4 contour_friction=10um rolling_friction=1um tilt=1deg:5deg:3")
    for spec in (egg, lens):
        assert spec.model.integrator(spec).module == "kernels.lossy_bodies.poles.integrate"
    starts = {name: np.array([1.5, -1.5]) for name in ("tilt", "tilt_rate")}
    assert egg.model.undisturbed(egg, starts).tolist() == [np.pi / 2, -np.pi / 2]
