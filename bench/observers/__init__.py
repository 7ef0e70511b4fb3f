"""Observers: processes of their own that watch a running world; bench starts them."""
