"""Our own OpenGL renderer, through moderngl and EGL: on a GPU, or on Mesa's software driver.

It needs no ROS, no display and no process of its own:

    from bullet_sim.render.gl.renderer import GlRenderer
    from bullet_sim.render.request import CameraRequest, Quality

    renderer = GlRenderer(Quality(shadows="false", antialias="false"))
    renderer.sync_sources(world.sources(), world.scene)     # again when models come or go
    camera = CameraRequest.from_spec(spec, model.source.key, row)
    rgb = renderer.draw(world.snapshot(), camera)           # (H, W, 3) uint8, top row first

`row` is Model.row(Model.link_in_body(spec.link)[0]), and the link's pose in that part goes before
the camera's (see bullet_bridge's CameraOutput); a CameraRequest with key None has its pose in the
world. With several cameras of one snapshot: `apply(snapshot)` once, then `render(camera, step)` for
each. A renderer belongs to the thread that made it, and its numbers are the same for the same
snapshot and camera on one driver.

`renderer` puts an image together; `scene` has the instances of all visuals (bullet_sim.kinematics
the poses of their links), `meshes` the uploaded triangles and textures, `shadows` the sun's shadow
maps, `shaders` the programs with their uniforms, `context` the framebuffers.
"""
