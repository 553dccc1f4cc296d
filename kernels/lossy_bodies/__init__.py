"""Bodies of revolution with losses; they share laws, step control and dry friction with the thin disk."""
