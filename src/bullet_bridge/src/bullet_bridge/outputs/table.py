"""Which output publishes which kind of sensor."""

from bullet_sim.description.specs import (
    CameraSpec,
    ContactSpec,
    DepthCameraSpec,
    GroundTruthSpec,
    ImuSpec,
    JointStatesSpec,
    RaySpec,
    WheelDriveSpec,
)

from bullet_bridge.outputs.contact import ContactOutput
from bullet_bridge.outputs.depth import DepthCameraOutput
from bullet_bridge.outputs.sensors import CameraOutput, GroundTruthOutput, ImuOutput, LidarOutput
from bullet_bridge.outputs.wheels import JointStatesOutput, WheelDriveOutput

OUTPUTS = {
    GroundTruthSpec: GroundTruthOutput,
    RaySpec: LidarOutput,
    ImuSpec: ImuOutput,
    CameraSpec: CameraOutput,
    DepthCameraSpec: DepthCameraOutput,
    ContactSpec: ContactOutput,
    JointStatesSpec: JointStatesOutput,
    WheelDriveSpec: WheelDriveOutput,
}
