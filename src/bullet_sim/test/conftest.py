"""The world of a test's module: of its WORLD, keywords of World, and by each of its SOLVERS."""

import pytest
from bullet_sim.world import World


def pytest_generate_tests(metafunc):
    solvers = getattr(metafunc.module, "SOLVERS", ())
    if solvers and "world" in metafunc.fixturenames:
        metafunc.parametrize("world", solvers, indirect=True)


@pytest.fixture
def world(request):
    solver = {"solver": request.param} if hasattr(request, "param") else {}
    made = World(**getattr(request.module, "WORLD", {}), **solver)
    yield made
    made.close()


@pytest.fixture(scope="module")
def gl(request):
    """The OpenGL renderer without antialiasing, with the SHADOWS of the test's module."""
    from bullet_sim.render.gl.renderer import GlRenderer
    from bullet_sim.render.request import Quality

    renderer = GlRenderer(Quality(getattr(request.module, "SHADOWS", "true"), "false"))
    yield renderer
    renderer.close()
