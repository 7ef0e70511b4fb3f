"""GLSL of the passes that have one program each: the sun's depth, labels and the sky."""

DEPTH_VERTEX = """
uniform mat4 shadow;
in vec3 in_position;
in vec4 in_row0;
in vec4 in_row1;
in vec4 in_row2;
void main() {
    vec4 local = vec4(in_position, 1.0);
    gl_Position = shadow * vec4(dot(in_row0, local), dot(in_row1, local), dot(in_row2, local), 1.0);
}
"""
DEPTH_FRAGMENT = "void main() {}"

LABEL_VERTEX = """
uniform mat4 clip;
in vec3 in_position;
in vec4 in_row0;
in vec4 in_row1;
in vec4 in_row2;
in vec4 in_label;
flat out vec4 v_label;
void main() {
    vec4 local = vec4(in_position, 1.0);
    gl_Position = clip * vec4(dot(in_row0, local), dot(in_row1, local), dot(in_row2, local), 1.0);
    v_label = in_label;
}
"""
LABEL_FRAGMENT = """
flat in vec4 v_label;
out vec4 out_color;
void main() { out_color = v_label; }
"""

SKY_VERTEX = """
uniform mat3 corner;   // columns: towards the picture's middle, its right edge, its upper edge
in vec2 in_corner;
out vec3 v_direction;
void main() {
    gl_Position = vec4(in_corner.x, -in_corner.y, 0.0, 1.0);
    v_direction = corner * vec3(1.0, in_corner);
}
"""
SKY_FRAGMENT = """
in vec3 v_direction;
uniform vec3 zenith;
uniform vec3 horizon;
out vec4 out_color;
void main() {
    float up = clamp(2.0 * v_direction.z * inversesqrt(dot(v_direction, v_direction)), 0.0, 1.0);
    out_color = vec4(mix(horizon, zenith, up), 1.0);
}
"""
