"""The physics: pause, reset, step, gravity; its properties, also by dynamic_reconfigure."""
