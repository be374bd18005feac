"""Every way to compensate friction that is compared, as blocks with their tuning ranges."""
