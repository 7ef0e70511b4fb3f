"""./run desk: a screen without a monitor, seen and used in a browser.

session.py starts the X server (it speaks VNC on a socket in a private folder) and the window
manager, and holds them together around the command that runs there; web.py is the program that
hands noVNC's page and the screen to browsers that know the token.
"""
