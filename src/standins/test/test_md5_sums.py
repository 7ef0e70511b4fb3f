"""The definitions' MD5 sums are ROS Noetic's; computed from the files, no build needed."""
import glob
import os

import pytest

from md5_table import SUMS

gentools = pytest.importorskip('genmsg.gentools')
msg_loader = pytest.importorskip('genmsg.msg_loader')
rospkg = pytest.importorskip('rospkg')

STANDINS = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
FOREIGN = ('actionlib_msgs', 'geometry_msgs', 'std_msgs', 'trajectory_msgs')


@pytest.fixture(name='search_path', scope='module')
def _search_path():
    places = [p for p in os.environ.get('ROS_PACKAGE_PATH', '').split(os.pathsep) if p]
    rospack = rospkg.RosPack(places + ['/opt/ros/noetic/share', '/usr/share'])
    path = {name: [os.path.join(rospack.get_path(name), 'msg')] for name in FOREIGN}
    for name in os.listdir(STANDINS):
        path[name] = [os.path.join(STANDINS, name, 'msg')]
    return path


def _sums(relative, search_path):
    package, _, file_name = relative.split('/')
    # A name of its own: the action GripperCommand holds the message GripperCommand.
    name = '%s/%sPart' % (package, file_name.split('.')[0])
    with open(os.path.join(STANDINS, relative), encoding='utf-8') as stream:
        parts = stream.read().split('---\n')
    sums = []
    for part in parts:
        context = msg_loader.MsgContext.create_default()
        spec = msg_loader.load_msg_from_string(context, part, name)
        msg_loader.load_depends(context, spec, search_path)
        sums.append(gentools.compute_md5(context, spec))
    return tuple(sums)


@pytest.mark.parametrize('relative', sorted(SUMS))
def test_sum(relative, search_path):
    assert _sums(relative, search_path) == SUMS[relative]


def test_every_definition_is_in_the_table():
    files = [f for kind in ('msg', 'srv', 'action')
             for f in glob.glob(os.path.join(STANDINS, '*', kind, '*.' + kind))]
    assert {os.path.relpath(f, STANDINS) for f in files} == set(SUMS)
