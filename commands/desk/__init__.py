"""./run desk: a screen without a monitor, seen and used in a browser.

screen.py starts the X server (it speaks VNC on a socket in a private folder), windows.py the window
manager, web.py is the program that hands noVNC's page and the screen to browsers that know the
token, session.py holds them together around the command that runs there.
"""
