"""What parameters are compared by: inverse model and output error."""
