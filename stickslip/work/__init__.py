"""Jobs on workers, and what is kept of them."""
