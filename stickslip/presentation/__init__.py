"""Pages, figures, tables and numbers as people read them."""
