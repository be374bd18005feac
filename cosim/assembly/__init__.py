"""From a system to the tables of the kernel."""
