"""Lenses that pinholes cannot show: pictures put together from pinholes."""
