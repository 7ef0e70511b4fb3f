"""Policies as ONNX files. No simulator, no ROS; torch only where one is exported."""
