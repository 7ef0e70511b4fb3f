"""For tests whose robots are sketches without masses, or without all of their inertia."""

import pytest


@pytest.fixture(scope="module")
def sketches():
    """No link of a URDF is left out or loses its shapes, as with massless_links 'keep'."""
    from bullet_sim.formats import urdf

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(urdf, "LEAVE_OUT", "never")
        yield
