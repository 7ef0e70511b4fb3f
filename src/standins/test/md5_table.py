"""MD5 sums of ROS Noetic's definitions: the contract with nodes built against the originals.

SUMS: services as (request, response), actions as (goal, result, feedback). CONNECTION: the sums
that are compared when a connection is made: of a service over both parts; of an action those of the
messages that wrap goal, result and feedback with header and id.

Where they come from: each sum of both tables was looked up, and found under its own name, in
message code that others generated from the original packages and published (roscpp, roslisp,
rosserial, gennodejs, and clients in C#, Swift and Elixir). None had to be taken from a list of
fields alone. Where an original changed, the sum is that of its last form, as Noetic has it:
GetModelState has a header since Jade (before: af0f702011820738976b120226dc9d96),
SwitchController has start_asap and timeout.

Those of gazebo_ros_link_attacher, geographic_msgs, hector_gazebo_plugins and
four_wheel_steering_msgs were computed from the originals' definitions; of these GeoPoint,
GeoPath and FourWheelSteering were found in such code, too.
"""

EMPTY = "d41d8cd98f00b204e9800998ecf8427e"
STATUS = "2ec6f3eff0161f4257b808b12bc830c2"  # bool success, string status_message
OK = "6f6da3883749771fac40d6deb24a8c02"  # bool ok

SUMS = {
    "ackermann_msgs/msg/AckermannDrive.msg": ("3512e91b48d69674a0e86fadf1ea8231",),
    "ackermann_msgs/msg/AckermannDriveStamped.msg": ("1fd5d7f58889cefd44d29f6653240d0c",),
    "control_msgs/msg/GripperCommand.msg": ("680acaff79486f017132a7f198d40f08",),
    "control_msgs/msg/JointControllerState.msg": ("987ad85e4756f3aef7f1e5e7fe0595d1",),
    "control_msgs/msg/JointJog.msg": ("1685da700c8c2e1254afc92a5fb89c96",),
    "control_msgs/msg/JointTolerance.msg": ("f544fe9c16cf04547e135dd6063ff5be",),
    "control_msgs/msg/JointTrajectoryControllerState.msg": ("10817c60c2486ef6b33e97dcd87f4474",),
    "control_msgs/msg/PidState.msg": ("b138ec00e886c10e73f27e8712252ea6",),
    "control_msgs/srv/QueryCalibrationState.srv": (EMPTY, "28af3beedcb84986b8e470dc5470507d"),
    "control_msgs/srv/QueryTrajectoryState.srv": (
        "556a4fb76023a469987922359d08a844",
        "1f1a6554ad060f44d013e71868403c1a",
    ),
    "control_msgs/action/FollowJointTrajectory.action": (
        "69636787b6ecbde4d61d711979bc7ecb",
        "493383b18409bfb604b4e26c676401d2",
        "10817c60c2486ef6b33e97dcd87f4474",
    ),
    "control_msgs/action/GripperCommand.action": (
        "86fd82f4ddc48a4cb6856cfa69217e43",
        "e4cbff56d3562bcf113da5a5adeef91f",
        "e4cbff56d3562bcf113da5a5adeef91f",
    ),
    "control_msgs/action/JointTrajectory.action": (
        "2a0eff76c870e8595636c2a562ca298e",
        EMPTY,
        EMPTY,
    ),
    "control_msgs/action/PointHead.action": (
        "8b92b1cd5e06c8a94c917dc3209a4c1d",
        EMPTY,
        "cce80d27fd763682da8805a73316cab4",
    ),
    "control_msgs/action/SingleJointPosition.action": (
        "fbaaa562a23a013fd5053e5f72cbb35c",
        EMPTY,
        "8cee65610a3d08e0a1bded82f146f1fd",
    ),
    "controller_manager_msgs/msg/ControllerState.msg": ("aeb6b261d97793ab74099a3740245272",),
    "controller_manager_msgs/msg/ControllerStatistics.msg": ("697780c372c8d8597a1436d0e2ad3ba8",),
    "controller_manager_msgs/msg/ControllersStatistics.msg": ("a154c347736773e3700d1719105df29d",),
    "controller_manager_msgs/msg/HardwareInterfaceResources.msg": (
        "f25b55cbf1d1f76e82e5ec9e83f76258",
    ),
    "controller_manager_msgs/srv/ListControllerTypes.srv": (
        EMPTY,
        "c1d4cd11aefa9f97ba4aeb5b33987f4e",
    ),
    "controller_manager_msgs/srv/ListControllers.srv": (EMPTY, "1341feb2e63fa791f855565d0da950d8"),
    "controller_manager_msgs/srv/LoadController.srv": ("c1f3d28f1b044c871e6eff2e9fc3c667", OK),
    "controller_manager_msgs/srv/ReloadControllerLibraries.srv": (
        "18442b59be9479097f11c543bddbac62",
        OK,
    ),
    "controller_manager_msgs/srv/SwitchController.srv": ("36d99a977432b71d4bf16ce5847949d7", OK),
    "controller_manager_msgs/srv/UnloadController.srv": ("c1f3d28f1b044c871e6eff2e9fc3c667", OK),
    "four_wheel_steering_msgs/msg/FourWheelSteering.msg": ("04dd0f55e1f168668af1e2587a7cdd2a",),
    "four_wheel_steering_msgs/msg/FourWheelSteeringStamped.msg": (
        "9226582df815bc6df9e3206bc05923af",
    ),
    "gazebo_msgs/msg/ContactState.msg": ("48c0ffb054b8c444f870cecea1ee50d9",),
    "gazebo_msgs/msg/ContactsState.msg": ("acbcb1601a8e525bf72509f18e6f668d",),
    "gazebo_msgs/msg/LinkState.msg": ("0818ebbf28ce3a08d48ab1eaa7309ebe",),
    "gazebo_msgs/msg/LinkStates.msg": ("48c080191eb15c41858319b4d8a609c2",),
    "gazebo_msgs/msg/ModelState.msg": ("9330fd35f2fcd82d457e54bd54e10593",),
    "gazebo_msgs/msg/ModelStates.msg": ("48c080191eb15c41858319b4d8a609c2",),
    "gazebo_msgs/msg/ODEJointProperties.msg": ("1b744c32a920af979f53afe2f9c3511f",),
    "gazebo_msgs/msg/ODEPhysics.msg": ("667d56ddbd547918c32d1934503dc335",),
    "gazebo_msgs/msg/PerformanceMetrics.msg": ("884f71fd5037b886ec5e126b83c4425a",),
    "gazebo_msgs/msg/SensorPerformanceMetric.msg": ("01762ded18cfe9ebc7c8222667c99547",),
    "gazebo_msgs/msg/WorldState.msg": ("de1a9de3ab7ba97ac0e9ec01a4eb481e",),
    "gazebo_msgs/srv/ApplyBodyWrench.srv": ("e37e6adf97eba5095baa77dffb71e5bd", STATUS),
    "gazebo_msgs/srv/ApplyJointEffort.srv": ("2c3396ab9af67a509ecd2167a8fe41a2", STATUS),
    "gazebo_msgs/srv/BodyRequest.srv": ("5eade9afe7f232d78005bd0cafeab755", EMPTY),
    "gazebo_msgs/srv/DeleteLight.srv": ("4fb676dfb4741fc866365702a859441c", STATUS),
    "gazebo_msgs/srv/DeleteModel.srv": ("ea31c8eab6fc401383cf528a7c0984ba", STATUS),
    "gazebo_msgs/srv/GetJointProperties.srv": (
        "0be1351618e1dc030eb7959d9a4902de",
        "cd7b30a39faa372283dc94c5f6457f82",
    ),
    "gazebo_msgs/srv/GetLightProperties.srv": (
        "4fb676dfb4741fc866365702a859441c",
        "9a19ddd5aab4c13b7643d1722c709f1f",
    ),
    "gazebo_msgs/srv/GetLinkProperties.srv": (
        "7d82d60381f1b66a30f2157f60884345",
        "a8619f92d17cfcc3958c0fd13299443d",
    ),
    "gazebo_msgs/srv/GetLinkState.srv": (
        "7551675c30aaa71f7c288d4864552001",
        "8ba55ad34f9c072e75c0de57b089753b",
    ),
    "gazebo_msgs/srv/GetModelProperties.srv": (
        "ea31c8eab6fc401383cf528a7c0984ba",
        "b7f370938ef77b464b95f1bab3ec5028",
    ),
    "gazebo_msgs/srv/GetModelState.srv": (
        "19d412713cefe4a67437e17a951e759e",
        "ccd51739bb00f0141629e87b792e92b9",
    ),
    "gazebo_msgs/srv/GetPhysicsProperties.srv": (EMPTY, "575a5e74786981b7df2e3afc567693a6"),
    "gazebo_msgs/srv/GetWorldProperties.srv": (EMPTY, "36bb0f2eccf4d8be971410c22818ba3f"),
    "gazebo_msgs/srv/JointRequest.srv": ("0be1351618e1dc030eb7959d9a4902de", EMPTY),
    "gazebo_msgs/srv/SetJointProperties.srv": ("331fd8f35fd27e3c1421175590258e26", STATUS),
    "gazebo_msgs/srv/SetJointTrajectory.srv": ("649dd2eba5ffd358069238825f9f85ab", STATUS),
    "gazebo_msgs/srv/SetLightProperties.srv": ("10d953f2306aec18460eb80dd94fdd47", STATUS),
    "gazebo_msgs/srv/SetLinkProperties.srv": ("68ac74a4be01b165bc305b5ccdc45e91", STATUS),
    "gazebo_msgs/srv/SetLinkState.srv": ("22a2c757d56911b6f27868159e9a872d", STATUS),
    "gazebo_msgs/srv/SetModelConfiguration.srv": ("160eae60f51fabff255480c70afa289f", STATUS),
    "gazebo_msgs/srv/SetModelState.srv": ("cb042b0e91880f4661b29ea5b6234350", STATUS),
    "gazebo_msgs/srv/SetPhysicsProperties.srv": ("abd9f82732b52b92e9d6bb36e6a82452", STATUS),
    "gazebo_msgs/srv/SpawnModel.srv": ("6d0eba5753761cd57e6263a056b79930", STATUS),
    "geographic_msgs/msg/BoundingBox.msg": ("f62e8b5e390a3ac7603250d46e8f8446",),
    "geographic_msgs/msg/GeoPath.msg": ("1476008e63041203a89257cfad97308f",),
    "geographic_msgs/msg/GeoPoint.msg": ("c48027a852aeff972be80478ff38e81a",),
    "geographic_msgs/msg/GeoPointStamped.msg": ("ea50d268b03080563c330351a21edc89",),
    "geographic_msgs/msg/GeoPose.msg": ("778680b5172de58b7c057d973576c784",),
    "geographic_msgs/msg/GeoPoseStamped.msg": ("cc409c8ed6064d8a846fa207bf3fba6b",),
    "geographic_msgs/msg/GeoPoseWithCovariance.msg": ("84c133e7220362d3d8aff8e415075357",),
    "geographic_msgs/msg/GeoPoseWithCovarianceStamped.msg": ("2cc818b24aae5ffa4fd33f5ee0bb5421",),
    "geographic_msgs/msg/KeyValue.msg": ("cf57fdc6617a881a88c16e768132149c",),
    "gazebo_ros_link_attacher/srv/Attach.srv": ("ff39d0bc8e054b10e21a2f298cb7fb05", OK),
    "hector_gazebo_plugins/srv/SetBias.srv": ("af1f260075d9ba9bd73ca10c6a45df07", EMPTY),
    "hector_gazebo_plugins/srv/SetReferenceGeoPose.srv": (
        "fe903ca95d0210defda73a1629604439",
        EMPTY,
    ),
}

CONNECTION = {
    "control_msgs/action/FollowJointTrajectory.action": (
        "cff5c1d533bf2f82dd0138d57f4304bb",
        "c4fb3b000dc9da4fd99699380efcc5d9",
        "d8920dc4eae9fc107e00999cce4be641",
    ),
    "control_msgs/action/GripperCommand.action": (
        "aa581f648a35ed681db2ec0bf7a82bea",
        "143702cb2df0f163c5283cedc5efc6b6",
        "653dff30c045f5e6ff3feb3409f4558d",
    ),
    "control_msgs/action/JointTrajectory.action": (
        "a99e83ef6185f9fdd7693efe99623a86",
        "1eb06eeff08fa7ea874431638cb52332",
        "aae20e09065c3809e8a8e87c4c8953fd",
    ),
    "control_msgs/action/PointHead.action": (
        "b53a8323d0ba7b310ba17a2d3a82a6b8",
        "1eb06eeff08fa7ea874431638cb52332",
        "33c9244957176bbba97dd641119e8460",
    ),
    "control_msgs/action/SingleJointPosition.action": (
        "4b0d3d091471663e17749c1d0db90f61",
        "1eb06eeff08fa7ea874431638cb52332",
        "3503b7cf8972f90d245850a5d8796cfa",
    ),
    "control_msgs/srv/QueryCalibrationState.srv": ("28af3beedcb84986b8e470dc5470507d",),
    "control_msgs/srv/QueryTrajectoryState.srv": ("ec93cdecbd8062d761aa52b7c90cd44b",),
    "controller_manager_msgs/srv/ListControllerTypes.srv": ("c1d4cd11aefa9f97ba4aeb5b33987f4e",),
    "controller_manager_msgs/srv/ListControllers.srv": ("1341feb2e63fa791f855565d0da950d8",),
    "controller_manager_msgs/srv/LoadController.srv": ("647e5c54b8d6468952d8d31f1efe96c0",),
    "controller_manager_msgs/srv/ReloadControllerLibraries.srv": (
        "40e8c411fd1797d2e2c486018f846040",
    ),
    "controller_manager_msgs/srv/SwitchController.srv": ("b29a7abc673b2c54c14b54e50f8d06a5",),
    "controller_manager_msgs/srv/UnloadController.srv": ("647e5c54b8d6468952d8d31f1efe96c0",),
    "gazebo_msgs/srv/ApplyBodyWrench.srv": ("585b9f9618aa0581b207e2f2d90866bc",),
    "gazebo_msgs/srv/ApplyJointEffort.srv": ("c0039811b8cc919490b3cff748cdf46b",),
    "gazebo_msgs/srv/BodyRequest.srv": ("5eade9afe7f232d78005bd0cafeab755",),
    "gazebo_msgs/srv/DeleteLight.srv": ("ae11ea8100d536d5b92c2b5917abf912",),
    "gazebo_msgs/srv/DeleteModel.srv": ("9ce56b4e9e54616de25d796dc972a262",),
    "gazebo_msgs/srv/GetJointProperties.srv": ("7b30be900f50aa21efec4a0ec92d91c9",),
    "gazebo_msgs/srv/GetLightProperties.srv": ("df2cef87e13e2e6990e81e8aaa454c19",),
    "gazebo_msgs/srv/GetLinkProperties.srv": ("0e06a70386d0ee3fb880c02f23fcd821",),
    "gazebo_msgs/srv/GetLinkState.srv": ("09d6c98cce97b35f7ab9bd70300657ab",),
    "gazebo_msgs/srv/GetModelProperties.srv": ("5717f7bd34ed990fa80e28b3015027a3",),
    "gazebo_msgs/srv/GetModelState.srv": ("4c515e936d3319c9610c559c60bfc3d4",),
    "gazebo_msgs/srv/GetPhysicsProperties.srv": ("575a5e74786981b7df2e3afc567693a6",),
    "gazebo_msgs/srv/GetWorldProperties.srv": ("36bb0f2eccf4d8be971410c22818ba3f",),
    "gazebo_msgs/srv/JointRequest.srv": ("0be1351618e1dc030eb7959d9a4902de",),
    "gazebo_msgs/srv/SetJointProperties.srv": ("15a76e921b1410c698d82782ea5fa370",),
    "gazebo_msgs/srv/SetJointTrajectory.srv": ("88f5c10979e3f9649d5ae87a3b12aa65",),
    "gazebo_msgs/srv/SetLightProperties.srv": ("e6f13430c57278bb364aca53a1bf5ebf",),
    "gazebo_msgs/srv/SetLinkProperties.srv": ("d534ce1b36ee99de0ffa806c3a6348f0",),
    "gazebo_msgs/srv/SetLinkState.srv": ("8a5146eb66ae4d26b0860b08f3f271be",),
    "gazebo_msgs/srv/SetModelConfiguration.srv": ("10e3139d3b669c40afc057d38956fff7",),
    "gazebo_msgs/srv/SetModelState.srv": ("5b3ab0281d4f5445def017e3a2e4a07b",),
    "gazebo_msgs/srv/SetPhysicsProperties.srv": ("97e2057080558ce4730434b5fae75c91",),
    "gazebo_msgs/srv/SpawnModel.srv": ("9ed9c82c96abe1a00c3e8cdaeee24413",),
    "gazebo_ros_link_attacher/srv/Attach.srv": ("c91fb3be70ce66d19130d40294cf4bd5",),
    "hector_gazebo_plugins/srv/SetBias.srv": ("af1f260075d9ba9bd73ca10c6a45df07",),
    "hector_gazebo_plugins/srv/SetReferenceGeoPose.srv": ("fe903ca95d0210defda73a1629604439",),
}
