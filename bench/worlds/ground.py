"""A plain ground for worlds of the core without a track."""

GROUND = (
    "<sdf version='1.6'><model name='ground'><static>true</static><link name='link'>"
    "<collision name='plane'><geometry><plane><normal>0 0 1</normal></plane></geometry>"
    "</collision></link></model></sdf>"
)
