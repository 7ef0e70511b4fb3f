"""Table of sensor specifications and their outputs."""

from bullet_sim.description.field_specs import (
    ForceTorqueSpec,
    GpsSpec,
    HandOfGodSpec,
    JointPosesSpec,
    JointTransformsSpec,
    LinkForceSpec,
    MagneticSpec,
    PlanarMoveSpec,
    RootTransformSpec,
)
from bullet_sim.description.ray_specs import CloudSpec, RangeSpec
from bullet_sim.description.specs import (
    CameraSpec,
    ContactSpec,
    DepthCameraSpec,
    GroundTruthSpec,
    ImuSpec,
    JointStatesSpec,
    RangeCameraSpec,
    RaySpec,
    WheelDriveSpec,
)

from bullet_bridge.outputs.contact import ContactOutput
from bullet_bridge.outputs.depth import DepthCameraOutput, RangeCameraOutput
from bullet_bridge.outputs.earth import GpsOutput, MagneticOutput
from bullet_bridge.outputs.motion.planar import PlanarMoveOutput
from bullet_bridge.outputs.motion.transforms import JointTransformsOutput, RootTransformOutput
from bullet_bridge.outputs.motion.wheels import JointStatesOutput, WheelDriveOutput
from bullet_bridge.outputs.rays import RangeOutput, cloud_output
from bullet_bridge.outputs.sensors import CameraOutput, GroundTruthOutput, ImuOutput, LidarOutput
from bullet_bridge.outputs.wrenches import (
    ForceTorqueOutput,
    HandOfGodOutput,
    JointPosesOutput,
    LinkForceOutput,
)

OUTPUTS = {
    GroundTruthSpec: GroundTruthOutput,
    RaySpec: LidarOutput,
    ImuSpec: ImuOutput,
    CameraSpec: CameraOutput,
    DepthCameraSpec: DepthCameraOutput,
    ContactSpec: ContactOutput,
    JointStatesSpec: JointStatesOutput,
    WheelDriveSpec: WheelDriveOutput,
    CloudSpec: cloud_output,
    RangeSpec: RangeOutput,
    GpsSpec: GpsOutput,
    MagneticSpec: MagneticOutput,
    PlanarMoveSpec: PlanarMoveOutput,
    RangeCameraSpec: RangeCameraOutput,
    ForceTorqueSpec: ForceTorqueOutput,
    LinkForceSpec: LinkForceOutput,
    HandOfGodSpec: HandOfGodOutput,
    JointPosesSpec: JointPosesOutput,
    JointTransformsSpec: JointTransformsOutput,
    RootTransformSpec: RootTransformOutput,
}
CAMERAS = (CameraSpec, DepthCameraSpec, RangeCameraSpec)  # their outputs need the renderer
