"""The camera of the window: frames, what is drawn into them, films of them."""
