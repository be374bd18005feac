"""The ground: what FMI is, and the toolchain that builds FMUs."""
