"""<sensor> and <plugin> elements: what each family says (specifications) and how it is read."""
