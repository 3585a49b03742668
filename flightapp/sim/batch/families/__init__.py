"""Families of layouts, one small file each: its parameters and how a seed draws one layout from them."""
