"""One command a file: ``add_to`` declares its name and options, ``run`` does it."""
