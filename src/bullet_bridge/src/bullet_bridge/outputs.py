"""Which output publishes which kind of sensor."""

from bullet_bridge.contact_output import ContactOutput
from bullet_bridge.depth_outputs import DepthCameraOutput
from bullet_bridge.sensor_outputs import (CameraOutput, GroundTruthOutput, ImuOutput,
                                          LidarOutput)
from bullet_bridge.wheel_outputs import JointStatesOutput, WheelDriveOutput
from bullet_sim.specs import (CameraSpec, ContactSpec, DepthCameraSpec, GroundTruthSpec, ImuSpec,
                              JointStatesSpec, RaySpec, WheelDriveSpec)

OUTPUTS = {GroundTruthSpec: GroundTruthOutput, RaySpec: LidarOutput, ImuSpec: ImuOutput,
           CameraSpec: CameraOutput, DepthCameraSpec: DepthCameraOutput,
           ContactSpec: ContactOutput, JointStatesSpec: JointStatesOutput,
           WheelDriveSpec: WheelDriveOutput}
