"""Films of pictures: the file, which frames are due, and a node that films a topic."""
