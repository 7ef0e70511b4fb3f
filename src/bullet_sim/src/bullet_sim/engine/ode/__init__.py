"""The engine 'ode': steps as Gazebo's ODE makes them."""
