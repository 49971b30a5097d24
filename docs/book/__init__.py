"""Puts the sources of the book together: the pages of `docs`, and those that are made from the program itself."""
