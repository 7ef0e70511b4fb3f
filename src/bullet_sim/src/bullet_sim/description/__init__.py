"""What a robot or a world consists of, as plain values: parts, sensors' specs, merged links."""
