"""GLSL of the program that draws surfaces, in variants made for what a batch needs.

`Programs` defines the names of the #if lines, and puts `frame.FRAME` before it. Light is added as
Gazebo Classic's fixed pipeline does, in the colours' own space:
    texel * (ambient + sum of diffuse * cosine * shadow * attenuation) + emissive + highlights
"""

VERTEX = """
in vec3 in_position;
in vec3 in_normal;
in vec2 in_uv;
in vec4 in_row0;
in vec4 in_row1;
in vec4 in_row2;
in vec4 in_color;
in vec4 in_ambient;   // w: shininess
in vec4 in_specular;
in vec4 in_emissive;
flat out vec4 v_color;
#if NEEDS_NORMAL
out vec3 v_normal;
#endif
#if SUN
out float v_facing;
#endif
#if NEEDS_PLACE
out vec3 v_place;
#endif
#if TEXTURED
out vec2 v_uv;
#endif
#if LIT
flat out vec3 v_ambient;
#endif
#if SHINY
flat out vec4 v_specular;
flat out vec3 v_emissive;
#endif
#if SHADOWED & 1
out vec3 v_fixed;
#endif
#if SHADOWED & 2
out vec3 v_moving;
#endif
void main() {
    vec4 local = vec4(in_position, 1.0);
    vec3 place = vec3(dot(in_row0, local), dot(in_row1, local), dot(in_row2, local));
    vec3 normal = vec3(dot(in_row0.xyz, in_normal), dot(in_row1.xyz, in_normal),
                       dot(in_row2.xyz, in_normal));
    gl_Position = clip * vec4(place, 1.0);
    v_color = in_color;
#if SUN || SHADOWED
    vec3 outward = normalize(normal);
#endif
#if NEEDS_NORMAL
    v_normal = normal;
#endif
#if SUN
    v_facing = dot(outward, sun.xyz);
#endif
#if NEEDS_PLACE
    v_place = place;
#endif
#if TEXTURED
    v_uv = in_uv;
#endif
#if LIT
    v_ambient = ambient.rgb * in_ambient.rgb;
#endif
#if SHINY
    v_specular = vec4(in_specular.rgb, in_ambient.w);
    v_emissive = in_emissive.rgb;
#endif
#if SHADOWED
    vec3 aside = outward * (0.1 + sqrt(max(1.0 - v_facing * v_facing, 0.0)));
#endif
#if SHADOWED & 1
    v_fixed = (fixed_shadow * vec4(place + sun.w * aside, 1.0)).xyz;
#endif
#if SHADOWED & 2
    v_moving = (moving_shadow * vec4(place + eye.w * aside, 1.0)).xyz;
#endif
}
"""

FRAGMENT = """
flat in vec4 v_color;
#if NEEDS_NORMAL
in vec3 v_normal;
#endif
#if SUN
in float v_facing;
#endif
#if NEEDS_PLACE
in vec3 v_place;
#endif
#if TEXTURED
in vec2 v_uv;
uniform sampler2D picture;
#endif
#if LIT
flat in vec3 v_ambient;
#endif
#if SHINY
flat in vec4 v_specular;
flat in vec3 v_emissive;
#endif
#if SHADOWED & 1
in vec3 v_fixed;
uniform sampler2DShadow fixed_map;
#endif
#if SHADOWED & 2
in vec3 v_moving;
uniform sampler2DShadow moving_map;
#endif
#if SHADOWED
float reached(sampler2DShadow map, vec3 at) {
    vec2 off = abs(at.xy - 0.5);
    return max(off.x, off.y) < 0.5 ? texture(map, at) : 1.0;
}
#endif
out vec4 out_color;
void main() {
    vec4 color = v_color;
#if TEXTURED
    vec4 texel = texture(picture, v_uv);
    color *= texel;
    if (color.a < 0.01) discard;
#endif
#if LIT
#if NEEDS_NORMAL
    vec3 normal = normalize(gl_FrontFacing ? v_normal : -v_normal);
#endif
    vec3 light = v_ambient;
#if NEEDS_PLACE
    vec3 back = eye.xyz - v_place;
    float away = length(back);
#endif
#if SHINY
    vec3 shine = v_emissive;
    vec3 view = back / away;
#endif
#if SUN
    float facing = max(gl_FrontFacing ? v_facing : -v_facing, 0.0);
#if SHADOWED == 1
    facing *= reached(fixed_map, v_fixed);
#elif SHADOWED == 2
    facing *= reached(moving_map, v_moving);
#elif SHADOWED == 3
    facing *= min(reached(fixed_map, v_fixed), reached(moving_map, v_moving));
#endif
    light += facing * sun_diffuse.rgb * v_color.rgb;
#if SHINY
    if (facing > 0.0) {
        float mirrored = max(dot(normal, normalize(sun.xyz + view)), 0.0);
        shine += pow(mirrored, v_specular.w) * sun_specular.rgb * v_specular.rgb;
    }
#endif
#endif
#if LIGHTS
    for (int i = 0; i < LIGHTS; i++) {
        vec3 towards = lights[i].place.xyz - v_place;
        float far = length(towards);
        towards = lights[i].fall.w > 0.5 ? towards / far : -lights[i].direction.xyz;
        float power = 1.0;
        if (lights[i].fall.w > 0.5) {
            power = far > lights[i].place.w ? 0.0
                : 1.0 / (lights[i].fall.x + far * (lights[i].fall.y + far * lights[i].fall.z));
        }
        if (lights[i].fall.w > 1.5) {
            float inside = dot(-towards, lights[i].direction.xyz);
            float part = (inside - lights[i].direction.w)
                / max(lights[i].diffuse.w - lights[i].direction.w, 1e-4);
            power *= part <= 0.0 ? 0.0 : pow(min(part, 1.0), lights[i].specular.w);
        }
        float cosine = max(dot(normal, towards), 0.0);
        light += cosine * power * lights[i].diffuse.rgb * v_color.rgb;
#if SHINY
        if (cosine > 0.0) {
            float turned = max(dot(normal, normalize(towards + view)), 0.0);
            shine += pow(turned, v_specular.w) * power * lights[i].specular.rgb * v_specular.rgb;
        }
#endif
    }
#endif
#if TEXTURED
    color.rgb = light * texel.rgb;
#else
    color.rgb = light;
#endif
#if SHINY
    color.rgb += shine;
#endif
#endif
#if FOG
#if !LIT
    float away = length(eye.xyz - v_place);
#endif
#if FOG == 1
    float clear = 1.0 - clamp((away - fog_reach.x) * fog_reach.y, 0.0, 1.0);
#elif FOG == 2
    float clear = exp(-away * fog_reach.z);
#else
    float clear = exp(-away * away * fog_reach.z * fog_reach.z);
#endif
    color.rgb = mix(fog.rgb, color.rgb, clear);
#endif
    out_color = color;
}
"""
