"""Descriptions of models as plain values: parts, sensor specifications, merged links."""
