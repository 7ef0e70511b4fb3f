"""For tests whose robots are sketches without masses."""

import pytest


@pytest.fixture(scope="module")
def sketches():
    """No link of a URDF is left out for its mass, as with massless_links 'keep'."""
    from bullet_sim.formats import urdf

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(urdf, "leave_out", lambda model: set())
        yield
