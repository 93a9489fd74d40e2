"""The nodes of the loop, one a file, in the order a key press meets them."""
