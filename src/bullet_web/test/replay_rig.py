"""A robot, and what a replay holds."""

import base64
import json
import re

import numpy as np

ARM = """<robot name="arm">
  <link name="base"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
    iyz="0"/></inertial>
    <visual><geometry><box size="0.2 0.4 0.6"/></geometry>
      <material name="red"><color rgba="1 0 0 1"/></material></visual></link>
  <link name="plate"><visual><origin xyz="0 0 0.1"/><geometry><sphere radius="0.1"/></geometry>
    <material name="clear"><color rgba="0 0 1 0.5"/></material></visual></link>
  <joint name="fixed" type="fixed"><parent link="base"/><child link="plate"/>
    <origin xyz="0 0 0.3"/></joint>
  <link name="wheel"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0"
    iyz="0"/></inertial>
    <visual><geometry><cylinder radius="0.05" length="0.02"/></geometry></visual></link>
  <joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/>
    <origin xyz="0.1 0 0"/><axis xyz="0 1 0"/></joint>
</robot>"""


def data_of(page):
    """What a page replays."""
    return json.loads(re.search(r"window\.REPLAY = (.*?);</script>", page, re.S)[1])


def numbers(text, kind):
    return np.frombuffer(base64.b64decode(text), kind)
