"""How far the vision carries, over noise, blur and size, and under every effect."""
