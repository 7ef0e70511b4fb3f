"""Colors of Gazebo 11.1 of single visuals under its sun.

Recorded from its camera's JPEG files, so a few gray levels inexact. From above, over a
background of 178, shadows off.
"""

# Elements of the <material> of a box, and its <transparency> -> RGB.
GIVEN = {
    "diffuse: 1 0 0 1": (255, 102, 102),
    "ambient: 1 0 0 1": (255, 176, 178),
    "ambient: 0.2 0.4 0.6 1; diffuse: 0.6 0.3 0.1 1": (128, 94, 80),
    "specular: 1 1 1 1": (255, 255, 255),
    "emissive: 0.5 0 0 1": (255, 255, 255),
    "ambient: 0.1 0.1 0.1; diffuse: 0.1 0.1 0.1; emissive: 0.5 0 0 1": (153, 29, 28),
    "ambient: 0.1 0.1 0.1; diffuse: 0.1 0.1 0.1; specular: 1 1 1 1": (28, 28, 28),
    "ambient: 1 0 0 1; diffuse: 1 0 0 0.3": (202, 125, 126),
    "ambient: 1 0 0 0.3; diffuse: 1 0 0 1": (253, 1, 0),
    "ambient: 1 0 0 1; diffuse: 1 0 0 1; transparency: 0.7": (202, 125, 126),
    "script: Gazebo/Red; transparency: 0.7": (201, 125, 126),
    "ambient: 1 0 0 1; diffuse: 1 0 0 1; lighting: 0": (255, 255, 255),
    "script: Gazebo/Red; lighting: 0": (255, 255, 255),
    "lighting: 0": (255, 255, 255),
    "lighting: 1": (255, 255, 255),
    "script: Gazebo/Grey; ambient: 1 1 1 1": (227, 227, 227),
    "script: Gazebo/Grey; diffuse: 0 1 0 1": (31, 208, 32),
    "script: Gazebo/Grey; ambient: 1 0 0 1; diffuse: 0 1 0 1; emissive: 0 0 .3": (102, 177, 75),
    "script: Gazebo/NoSuchThing": (255, 255, 255),
    "script: Gazebo/NoSuchThing; diffuse: 0 1 0 1": (103, 255, 102),
    "ambient: 1 1 1 1; diffuse: 2 0.5 0.5 1": (103, 191, 193),
}

# Gazebo/NAME -> RGB.
NAMED = {
    "Grey": (155, 155, 155),
    "DarkGrey": (57, 57, 57),
    "White": (255, 255, 255),
    "FlatBlack": (28, 28, 28),
    "Black": (5, 5, 5),
    "Red": (255, 5, 6),
    "RedBright": (255, 85, 23),
    "Green": (5, 255, 5),
    "Blue": (5, 4, 255),
    "SkyBlue": (18, 51, 254),
    "Yellow": (255, 255, 0),
    "ZincYellow": (255, 255, 67),
    "DarkYellow": (196, 196, 0),
    "Purple": (255, 4, 255),
    "Turquoise": (5, 255, 254),
    "Orange": (255, 143, 15),
    "Indigo": (97, 4, 144),
    "WhiteGlow": (255, 255, 255),
    "RedGlow": (254, 0, 0),
    "GreenGlow": (255, 255, 255),
    "Gold": (197, 152, 35),
    "Pioneer2Body": (185, 17, 16),
    "RedTransparent": (217, 89, 88),
    "GreenTransparent": (88, 217, 90),
    "GreyTransparent": (159, 159, 159),
    "OrangeTransparentOverlay": (242, 139, 46),
    "LightOn": (0, 255, 1),
    "LightOff": (254, 0, 0),
    "OrangeTransparent": (208, 156, 108),
    "JointAnchor": (255, 255, 255),
    "CeilingTiled": (208, 208, 208),
    "Residential": (71, 70, 65),
    "Grass": (52, 106, 8),
    "DarkRed": (255, 255, 255),
}

# Body of the pass of a material script -> RGB of the quarters: upper left, upper right, lower left,
# lower right, or of all.
PASSES = {
    "texture_unit { texture quarters.png }": [(247, 3, 3), (1, 255, 2), (0, 1, 253), (255, 254, 1)],
    "texture_unit { texture half.png }": [(140, 140, 140)],
    "ambient 0.5 0.5 0.5 1\n diffuse 0.5 0.5 0.5 1\n texture_unit { texture half.png }": [
        (70, 70, 70)
    ],
    "texture_unit { texture quarters.png\n scale 0.5 0.25 }": [
        (237, 252, 12),
        (25, 3, 222),
        (8, 251, 9),
        (247, 116, 122),
    ],
    "texture_unit { texture quarters.png\n scale 2 4 }": [
        (253, 1, 0),
        (1, 255, 2),
        (0, 1, 253),
        (255, 254, 2),
    ],
    "texture_unit { texture quarters.png\n scroll 0.25 0.125 }": [
        (232, 6, 36),
        (232, 5, 37),
        (1, 1, 252),
        (0, 1, 252),
    ],
    "texture_unit { texture quarters.png\n rotate 30 }": [
        (238, 88, 86),
        (229, 254, 13),
        (173, 7, 78),
        (255, 252, 3),
    ],
    "texture_unit { texture quarters.png\n scale 0.5 0.5\n scroll 0.1 0.2\n rotate 20 }": [
        (160, 116, 26),
        (4, 3, 241),
        (251, 253, 5),
        (193, 54, 4),
    ],
    "lighting off\n texture_unit { texture half.png }": [(128, 128, 128)],
    "lighting off\n ambient 1 0 0\n diffuse 1 0 0 1": [(255, 255, 255)],
    "texture_unit { texture holes.png }": [(253, 1, 0)],
    "alpha_rejection greater 128\n texture_unit { texture holes.png }": [
        (253, 1, 0),
        (178, 178, 178),
        (253, 1, 0),
        (178, 178, 178),
    ],
    "scene_blend alpha_blend\n depth_write off\n texture_unit { texture holes.png }": [
        (254, 0, 0),
        (194, 137, 137),
        (254, 0, 0),
        (194, 137, 137),
    ],
    "scene_blend add\n depth_write off\n ambient 0.2 0 0\n diffuse 0.3 0.1 0.1 1": [
        (253, 195, 197)
    ],
    "scene_blend alpha_blend\n depth_write off\n ambient 0 0 1\n diffuse 0 0 1 0.3": [
        (126, 125, 202)
    ],
    "texture_unit { texture quarters.png\n filtering none\n scale 8 8 }": [
        (253, 1, 0),
        (1, 255, 2),
        (0, 1, 253),
        (255, 254, 2),
    ],
    "ambient 0.2 0.2 0.2\n diffuse 0.3 0.3 0.3\n specular 1 1 1 1 2": [(119, 119, 119)],
    "ambient 0 0 0\n diffuse 0 0 0\n emissive 0.5 0.25 0\n texture_unit { texture half.png }": [
        (65, 32, 1)
    ],
}
