"""<gazebo> elements of a URDF: surfaces, ros_control, sensors with their ROS plugins."""

from bullet_sim.description import ModelDescription
from bullet_sim.specs import CameraSpec, GroundTruthSpec, ImuSpec, RaySpec
from bullet_sim.xml_read import child_number, child_text, is_true, sdf_pose

_SURFACE_TAGS = {'mu1', 'mu2', 'kp', 'kd'}
_QUIET_TAGS = {'material', 'selfCollide', 'gravity', 'turnGravityOff', 'fdir1', 'maxVel',
               'minDepth', 'maxContacts', 'sensor', 'plugin', 'dampingFactor', 'static',
               'implicitSpringDamper', 'provideFeedback', 'preserveFixedJoint', 'visual',
               'disableFixedJointLumping', 'laserRetro', 'self_collide', 'initial_joint_position'}


def apply(robot, model: ModelDescription):
    """Read every <gazebo> child of <robot> into the model description."""
    for element in robot.findall('gazebo'):
        reference = element.get('reference')
        if reference in model.links:
            _surface(element, model, reference)
        for sensor in element.findall('sensor'):
            if reference not in model.links:
                model.warn(f"sensor '{sensor.get('name')}' refers to link '{reference}', "
                           'which does not exist; it is left out')
                continue
            spec = parse_sensor(sensor, reference, model)
            if spec is not None:
                model.sensors.append(spec)
        for plugin in element.findall('plugin'):
            _plugin(plugin, model)


def _surface(element, model, reference):
    surface = model.links[reference].surface
    what = f"<gazebo reference='{reference}'>"
    mu1 = child_number(element, 'mu1', what, None)
    mu2 = child_number(element, 'mu2', what, None)
    frictions = [mu for mu in (mu1, mu2) if mu is not None]
    if frictions:
        surface.friction = min(frictions)
        if len(set(frictions)) > 1:
            model.warn(f'{what} has mu1 {mu1} and mu2 {mu2}; PyBullet has one friction for '
                       f'both directions: the smaller, {surface.friction}')
    stiffness = child_number(element, 'kp', what, None)
    if stiffness is not None and stiffness < 1e5:
        surface.stiffness = stiffness
        surface.damping = child_number(element, 'kd', what, 1.0)
    for child in element:
        if child.tag not in _SURFACE_TAGS | _QUIET_TAGS:
            model.warn(f'{what}: <{child.tag}> means nothing here and is ignored')


def _plugin(element, model):
    filename = (element.get('filename') or '').rsplit('/', 1)[-1]
    what = f"plugin '{filename}'"
    if filename in ('libgazebo_ros_control.so', 'libgazebo_ros_control'):
        model.control_namespace = child_text(element, 'robotNamespace', '')
    elif filename == 'libgazebo_ros_p3d.so':
        link = child_text(element, 'bodyName', model.root)
        if link not in model.links:
            model.warn(f"{what} has bodyName '{link}', which is no link; it is left out")
            return
        model.sensors.append(GroundTruthSpec(
            link=link, topic=_topic(element, child_text(element, 'topicName', 'ground_truth')),
            frame_id=child_text(element, 'frameName', 'world'),
            rate=child_number(element, 'updateRate', what, 0.0) or 100.0,
            twist_in_child=child_text(element, 'twistFrame', 'world') == 'child',
            child_frame_id=link,
            noise_stddev=child_number(element, 'gaussianNoise', what, 0.0)))
    else:
        model.warn(f'{what} is not known here and is ignored')


def _topic(plugin, name):
    """Full topic name: absolute names stay, others go below <robotNamespace>."""
    if name.startswith('/'):
        return name
    namespace = child_text(plugin, 'robotNamespace', '').strip('/')
    return '/'.join(['', namespace, name] if namespace else ['', name])


def parse_sensor(element, link, model):
    """Specification of one <sensor>, or None with a warning when its kind is not known."""
    kind, name = element.get('type'), element.get('name') or 'sensor'
    reader = _SENSORS.get(kind)
    if reader is None:
        model.warn(f"sensor '{name}' has type '{kind}', known are {', '.join(_SENSORS)}; "
                   'it is left out')
        return None
    plugin = element.find('plugin')
    if plugin is None:
        model.warn(f"sensor '{name}' has no ROS plugin and so no topic; it is left out")
        return None
    pose = sdf_pose(element, f"sensor '{name}'")
    return reader(element, plugin, name, link, (pose.position, pose.rpy))


def _rate(element, plugin, what, default):
    rate = child_number(plugin, 'updateRate', what, 0.0)
    return rate or child_number(element, 'update_rate', what, 0.0) or default


def _camera(element, plugin, name, link, pose):
    what = f"camera '{name}'"
    camera = element.find('camera')
    camera = element if camera is None else camera
    base = child_text(plugin, 'cameraName', 'camera')

    def topic(tag, default):
        text = child_text(plugin, tag, default)
        return _topic(plugin, text if text.startswith('/') else f"{base.rstrip('/')}/{text}")
    return CameraSpec(
        name=name, link=link, pose=pose,
        width=int(child_number(camera, 'image/width', what, 320)),
        height=int(child_number(camera, 'image/height', what, 240)),
        horizontal_fov=child_number(camera, 'horizontal_fov', what, 1.047),
        near=child_number(camera, 'clip/near', what, 0.1),
        far=child_number(camera, 'clip/far', what, 100.0),
        rate=_rate(element, plugin, what, 30.0), topic=topic('imageTopicName', 'image_raw'),
        info_topic=topic('cameraInfoTopicName', 'camera_info'),
        frame_id=child_text(plugin, 'frameName', link),
        noise_stddev=child_number(camera, 'noise/stddev', what, 0.0))


def _ray(element, plugin, name, link, pose):
    what = f"lidar '{name}'"
    ray = element.find('ray')
    ray = element if ray is None else ray
    return RaySpec(
        name=name, link=link, pose=pose,
        samples=int(child_number(ray, 'scan/horizontal/samples', what, 360)),
        min_angle=child_number(ray, 'scan/horizontal/min_angle', what, -3.14159265),
        max_angle=child_number(ray, 'scan/horizontal/max_angle', what, 3.14159265),
        range_min=child_number(ray, 'range/min', what, 0.1),
        range_max=child_number(ray, 'range/max', what, 10.0),
        rate=_rate(element, plugin, what, 10.0),
        noise_stddev=child_number(ray, 'noise/stddev', what,
                                  child_number(plugin, 'gaussianNoise', what, 0.0)),
        topic=_topic(plugin, child_text(plugin, 'topicName', 'scan')),
        frame_id=child_text(plugin, 'frameName', link),
        visualize=is_true(child_text(element, 'visualize', 'false')))


def _imu(element, plugin, name, link, pose):
    what = f"imu '{name}'"
    return ImuSpec(name=name, link=link, pose=pose, rate=_rate(element, plugin, what, 100.0),
                   topic=_topic(plugin, child_text(plugin, 'topicName', 'imu')),
                   frame_id=child_text(plugin, 'frameName', link),
                   gyro_noise_stddev=child_number(plugin, 'gaussianNoise', what, 0.0),
                   accel_noise_stddev=child_number(plugin, 'gaussianNoise', what, 0.0))


_SENSORS = {'camera': _camera, 'ray': _ray, 'gpu_ray': _ray, 'imu': _imu}
