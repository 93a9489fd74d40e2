"""What the screen of a study is made of."""
