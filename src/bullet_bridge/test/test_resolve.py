"""URIs and relative world files become paths."""
import os

import pytest
import rospkg

from bullet_bridge import node
from bullet_bridge.resolve import Resolver, find_world
from bullet_sim.errors import SimError

WORLD = '<sdf version="1.6"><world name="w"/></sdf>'


@pytest.fixture(name='models')
def model_folder(tmp_path, monkeypatch):
    """A model folder on GAZEBO_MODEL_PATH."""
    (tmp_path / 'cone').mkdir()
    (tmp_path / 'cone' / 'model.sdf').write_text('<sdf/>')
    (tmp_path / 'cone' / 'cone.obj').write_text('')
    monkeypatch.setenv('GAZEBO_MODEL_PATH', f'/nowhere:{tmp_path}')
    return tmp_path


def test_package():
    share = rospkg.RosPack().get_path('bullet_bridge')
    assert Resolver()('package://bullet_bridge/package.xml') == f'{share}/package.xml'


def test_unknown_package_is_named():
    with pytest.raises(ValueError, match="package 'no_such_pkg'"):
        Resolver()('package://no_such_pkg/a.stl')


def test_model_by_name_and_file(models):
    resolve = Resolver()
    assert resolve('model://cone') == str(models / 'cone' / 'model.sdf')
    assert resolve('model://cone/cone.obj') == str(models / 'cone' / 'cone.obj')


def test_model_path_of_a_package():
    share = rospkg.RosPack().get_path('bullet_bridge')
    assert Resolver()('model://bullet_bridge/package.xml') == f'{share}/package.xml'


def test_unknown_model_names_it_and_the_folders(models):
    with pytest.raises(ValueError) as error:
        Resolver()('model://no_such_model')
    assert 'no_such_model' in str(error.value)
    assert str(models) in str(error.value) and '/nowhere' in str(error.value)


def test_file_and_absolute_path():
    assert Resolver()('file:///a/b.stl') == '/a/b.stl'
    assert Resolver()('/a/b.stl') == '/a/b.stl'


@pytest.mark.parametrize('uri, text', [('http://x/y.stl', "scheme 'http'"),
                                       ('b.stl', 'absolute path'), ('', 'absolute path')])
def test_other_uris_are_errors(uri, text):
    with pytest.raises(ValueError, match=text):
        Resolver()(uri)


def test_world_file_as_it_is(tmp_path, monkeypatch):
    (tmp_path / 'a.world').write_text(WORLD)
    monkeypatch.chdir(tmp_path)
    assert find_world('a.world') == 'a.world'
    assert find_world(str(tmp_path / 'a.world')) == str(tmp_path / 'a.world')


def test_world_file_in_resource_path(tmp_path, monkeypatch):
    (tmp_path / 'worlds').mkdir()
    (tmp_path / 'worlds' / 'empty.world').write_text(WORLD)
    monkeypatch.setenv('GAZEBO_RESOURCE_PATH', f'/nowhere::{tmp_path}')
    assert find_world('worlds/empty.world') == str(tmp_path / 'worlds' / 'empty.world')


def test_world_file_of_gazebo_ros(monkeypatch):
    monkeypatch.delenv('GAZEBO_RESOURCE_PATH', raising=False)
    share = rospkg.RosPack().get_path('gazebo_ros')
    assert find_world('worlds/empty.world') == f'{share}/worlds/empty.world'


def test_missing_world_file_names_all_places(tmp_path, monkeypatch):
    monkeypatch.setenv('GAZEBO_RESOURCE_PATH', f'/nowhere:{tmp_path}')
    with pytest.raises(ValueError) as error:
        find_world('worlds/none.world')
    for part in ('worlds/none.world', os.getcwd(), '/nowhere', str(tmp_path),
                 rospkg.RosPack().get_path('gazebo_ros')):
        assert part in str(error.value)


def test_load_world_finds_a_relative_file(tmp_path, monkeypatch):
    class Taker:
        """Stands in for World."""

        loaded = None

        def load(self, described):
            """Keep it."""
            self.loaded = described
            return []
    (tmp_path / 'w.world').write_text(WORLD)
    monkeypatch.setenv('GAZEBO_RESOURCE_PATH', str(tmp_path))
    taker = Taker()
    node.load_world(taker, 'w.world', Resolver())
    assert taker.loaded.name == 'w'
    with pytest.raises(SimError, match='/no/such.world.*No such file'):
        node.load_world(taker, '/no/such.world', Resolver())
