"""SDF subset -> models, for worlds and for spawned SDF models."""

from dataclasses import dataclass, field
from typing import List, Tuple

import numpy as np

from bullet_sim.description import Geometry, Joint, Link, ModelDescription, Shape
from bullet_sim.errors import ModelError
from bullet_sim.gazebo_tags import parse_sensor
from bullet_sim.pose import Pose
from bullet_sim.urdf import mesh_geometry, positive
from bullet_sim.xml_read import child_number, child_text, floats, is_true, parse, sdf_pose

# Built-in models of every Gazebo: the ground is an infinite plane, the sun is only light.
GROUND_COLOR = (0.6, 0.6, 0.6, 1.0)
NOTHING = ('sun',)


@dataclass
class WorldDescription:
    """What a world file holds; models with their world poses, in file order."""

    name: str = 'default'
    gravity: Tuple[float, float, float] = (0.0, 0.0, -9.81)
    step: float = 0.001
    real_time_factor: float = 1.0
    models: List[Tuple[ModelDescription, Pose]] = field(default_factory=list)
    warnings: List[str] = field(default_factory=list)


def parse_world(text, resolve, what='world'):
    """Read a world.

    Args:
        text: SDF document with a <world>.
        resolve: function URI -> path of a file.
        what: name for messages, e.g. the file's path.

    Raises:
        ModelError: malformed or wrong numbers.
    """
    sdf = parse(text, what)
    world = sdf.find('world') if sdf.tag == 'sdf' else None
    if world is None:
        raise ModelError(f'{what} has no <world> in an <sdf>')
    described = WorldDescription(world.get('name') or 'default')
    gravity = child_text(world, 'gravity') or child_text(world, 'physics/gravity')
    if gravity:
        described.gravity = floats(gravity, 3, f'{what} <gravity>')
    described.step = child_number(world, 'physics/max_step_size', what, 0.001)
    if described.step <= 0:
        raise ModelError(f'{what} <max_step_size> is {described.step}, must be greater than 0')
    for element in world:
        if element.tag == 'include':
            _include(element, described, resolve, what)
        elif element.tag == 'model':
            described.models.append(_placed(element, resolve, what))
    return described


def _include(element, described, resolve, what):
    uri = child_text(element, 'uri', '')
    plain = uri.replace('model://', '').strip('/')
    pose = sdf_pose(element, f'{what} <include>')
    if plain in NOTHING:
        return
    if plain == 'ground_plane':
        described.models.append((ground_plane(), pose))
        return
    try:
        path = resolve(uri)
        with open(path, encoding='utf-8') as file:
            model, own = parse_model(file.read(), resolve, path)
    except (OSError, ValueError) as error:
        described.warnings.append(f"{what} includes '{uri}', which cannot be used: {error}")
        return
    model.name = child_text(element, 'name', model.name)
    model.static = is_true(child_text(element, 'static', str(model.static)))
    described.models.append((model, pose if element.find('pose') is not None else own))


def ground_plane():
    """The built-in endless floor at z = 0, friction 1."""
    model = ModelDescription('ground_plane', root='link', static=True)
    link = Link('link')
    link.surface.friction = 1.0
    link.collisions.append(Shape(Geometry('plane')))
    link.visuals.append(Shape(Geometry('box', (100.0, 100.0, 0.002)),
                              Pose((0.0, 0.0, -0.003)), GROUND_COLOR))
    model.links['link'] = link
    return model


def _placed(element, resolve, what):
    return _model(element, resolve), sdf_pose(element, f"{what} model '{element.get('name')}'")


def parse_model(text, resolve, what='model'):
    """Read an SDF document with one <model>: (ModelDescription, its own pose)."""
    sdf = parse(text, what)
    element = sdf if sdf.tag == 'model' else sdf.find('model')
    if element is None:
        raise ModelError(f'{what} has no <model>')
    return _placed(element, resolve, what)


def _model(element, resolve):
    model = ModelDescription(element.get('name') or 'model')
    model.static = is_true(child_text(element, 'static', 'false'))
    poses = {}
    for link_element in element.findall('link'):
        link = _link(link_element, model, resolve)
        if link.name in model.links:
            raise ModelError(f"model '{model.name}' has two links named '{link.name}'")
        model.links[link.name] = link
        poses[link.name] = sdf_pose(link_element, f"link '{link.name}'")
    if not model.links:
        raise ModelError(f"model '{model.name}' has no link")
    children = []
    for joint_element in element.findall('joint'):
        joint = _joint(joint_element, model, poses)
        if joint is not None:
            model.joints[joint.name] = joint
            children.append(joint.child)
    model.root = next((name for name in model.links if name not in children), '')
    if not model.root:
        raise ModelError(f"joints of model '{model.name}' form a loop, no link is the root")
    for name in model.links:
        if name != model.root and name not in children:
            joint = Joint(f'{name}__fixed', 'fixed', model.root, name,
                          poses[model.root].inverse() * poses[name])
            model.joints[joint.name] = joint
            if not model.static:
                model.warn(f"link '{name}' of '{model.name}' has no joint; "
                           f"it is fixed to '{model.root}'")
    if model.unreachable():
        raise ModelError(f"joints of model '{model.name}' form a loop: no way from its root "
                         f"'{model.root}' to {', '.join(model.unreachable())}")
    _shift_root(model, poses[model.root])
    for plugin in element.findall('plugin'):
        model.warn(f"plugin '{plugin.get('filename')}' is not known here and is ignored")
    return model


def _shift_root(model, pose):
    """Make the root link's frame the model's frame."""
    if pose == Pose():
        return
    root = model.links[model.root]
    root.centre = np.asarray(pose.position) + pose.matrix @ root.centre
    root.inertia = pose.matrix @ root.inertia @ pose.matrix.T
    for shapes in (root.visuals, root.collisions):
        shapes[:] = [Shape(s.geometry, pose * s.pose, s.color) for s in shapes]
    for joint in model.joints_of(model.root):
        joint.origin = pose * joint.origin


def _link(element, model, resolve):
    link = Link(element.get('name') or 'link')
    what = f"link '{link.name}' of '{model.name}'"
    inertial = element.find('inertial')
    link.mass = 1.0
    link.inertia = np.eye(3)
    if inertial is not None:
        link.mass = child_number(inertial, 'mass', what, 1.0)
        pose = sdf_pose(inertial, f'{what} inertial')
        entry = {key: child_number(inertial, f'inertia/{key}', what, default)
                 for key, default in (('ixx', 1.0), ('ixy', 0.0), ('ixz', 0.0), ('iyy', 1.0),
                                      ('iyz', 0.0), ('izz', 1.0))}
        local = np.array([[entry['ixx'], entry['ixy'], entry['ixz']],
                          [entry['ixy'], entry['iyy'], entry['iyz']],
                          [entry['ixz'], entry['iyz'], entry['izz']]])
        link.inertia = pose.matrix @ local @ pose.matrix.T
        link.centre = np.array(pose.position)
    for tag, shapes in (('visual', link.visuals), ('collision', link.collisions)):
        for number, shape_element in enumerate(element.findall(tag)):
            name = f'{what} {tag} {number}'
            geometry = _geometry(shape_element.find('geometry'), name, model, resolve, tag)
            if geometry is not None:
                positive(geometry, name)
                pose = sdf_pose(shape_element, name)
                if geometry.kind == 'box' and len(geometry.size) == 2:
                    geometry = Geometry('box', geometry.size + (0.002,))
                    pose = pose * Pose((0.0, 0.0, -0.001))
                shapes.append(Shape(geometry, pose, _color(shape_element, name, geometry)))
    frictions = [child_number(c, 'surface/friction/ode/mu', what, None)
                 for c in element.findall('collision')]
    frictions = [mu for mu in frictions if mu is not None]
    if link.collisions:
        link.surface.friction = min(frictions) if frictions else 1.0
    for sensor in element.findall('sensor'):
        spec = parse_sensor(sensor, link.name, model)
        if spec is not None:
            model.sensors.append(spec)
    return link


def _color(element, what, geometry):
    text = child_text(element, 'material/diffuse') or child_text(element, 'material/ambient')
    if text is not None:
        return (tuple(floats(text, None, f'{what} material')) + (1.0, 1.0, 1.0, 1.0))[:4]
    return None if geometry.kind == 'mesh' else (0.7, 0.7, 0.7, 1.0)


def _geometry(element, what, model, resolve, tag):
    if element is None or not len(element):
        return None
    shape = element[0]
    if shape.tag == 'plane':
        if tag == 'collision':
            return Geometry('plane')
        return Geometry('box', floats(child_text(shape, 'size', '100 100'), 2, f'{what} plane'))
    if shape.tag == 'box':
        return Geometry('box', floats(child_text(shape, 'size', '1 1 1'), 3, f'{what} box'))
    if shape.tag == 'cylinder':
        return Geometry('cylinder', (child_number(shape, 'radius', what, 0.5),
                                     child_number(shape, 'length', what, 1.0)))
    if shape.tag == 'sphere':
        return Geometry('sphere', (child_number(shape, 'radius', what, 0.5),))
    if shape.tag == 'mesh':
        scale = floats(child_text(shape, 'scale', '1 1 1'), 3, f'{what} mesh scale')
        return mesh_geometry(child_text(shape, 'uri', ''), scale, what, resolve, model)
    model.warn(f'{what} has geometry <{shape.tag}>, which is not known; it is left out')
    return None


def _joint(element, model, poses):
    name, kind = element.get('name') or 'joint', element.get('type')
    parent, child = child_text(element, 'parent'), child_text(element, 'child')
    what = f"joint '{name}' of '{model.name}'"
    if child not in model.links or parent not in model.links:
        if parent == 'world':
            model.static = True
            return None
        raise ModelError(f"{what} joins '{parent}' and '{child}', links are "
                         f"{', '.join(model.links)}")
    kinds = {'fixed': 'fixed', 'revolute': 'revolute', 'prismatic': 'prismatic'}
    if kind not in kinds:
        raise ModelError(f"{what} has type '{kind}', must be one of {', '.join(kinds)}")
    joint = Joint(name, kind, parent, child, poses[parent].inverse() * poses[child])
    if kind != 'fixed':
        axis = np.array(floats(child_text(element, 'axis/xyz', '0 0 1'), 3, f'{what} axis'))
        if np.linalg.norm(axis) < 1e-9:
            raise ModelError(f'{what} axis is zero, must have a direction')
        joint.axis = tuple((axis / np.linalg.norm(axis)).tolist())
        lower = child_number(element, 'axis/limit/lower', what, -1e16)
        upper = child_number(element, 'axis/limit/upper', what, 1e16)
        if lower > -1e15 or upper < 1e15:
            joint.lower, joint.upper = lower, upper
        joint.effort = max(0.0, child_number(element, 'axis/limit/effort', what, 0.0))
        joint.velocity = max(0.0, child_number(element, 'axis/limit/velocity', what, 0.0))
        joint.damping = child_number(element, 'axis/dynamics/damping', what, 0.0)
        joint.friction = child_number(element, 'axis/dynamics/friction', what, 0.0)
    return joint
