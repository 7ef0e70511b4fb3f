"""Observers: processes of their own that monitor a running world; bench starts them."""
