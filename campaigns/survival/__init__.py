"""Results survive: processes killed, disks filled and folders removed while they are written."""
