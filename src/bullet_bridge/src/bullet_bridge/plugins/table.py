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

from bullet_bridge.plugins.cameras import CameraOutput, DepthCameraOutput, RangeCameraOutput
from bullet_bridge.plugins.drives import (
    HandOfGodOutput,
    JointPosesOutput,
    JointStatesOutput,
    LinkForceOutput,
    PlanarMoveOutput,
    WheelDriveOutput,
)
from bullet_bridge.plugins.lidars import LidarOutput, RangeOutput, cloud_output
from bullet_bridge.plugins.measurements import (
    ContactOutput,
    ForceTorqueOutput,
    GpsOutput,
    GroundTruthOutput,
    ImuOutput,
    MagneticOutput,
)
from bullet_bridge.plugins.transforms import JointTransformsOutput, RootTransformOutput

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
