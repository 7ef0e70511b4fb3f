"""Table of sensor specifications and their outputs."""

from bullet_sim.plugins.cameras import CameraSpec, DepthCameraSpec, RangeCameraSpec
from bullet_sim.plugins.drives import (
    JointStatesSpec,
    JointTransformsSpec,
    PlanarMoveSpec,
    RootTransformSpec,
    WheelDriveSpec,
)
from bullet_sim.plugins.forces import (
    ContactSpec,
    ForceTorqueSpec,
    HandOfGodSpec,
    JointPosesSpec,
    LinkForceSpec,
)
from bullet_sim.plugins.inertial import GpsSpec, GroundTruthSpec, ImuSpec, MagneticSpec
from bullet_sim.plugins.lidars import CloudSpec, RangeSpec, RaySpec

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
