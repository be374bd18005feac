"""The workbench in the browser: it shows and starts what the public Python interface does."""
