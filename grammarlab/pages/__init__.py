"""Pages in a browser, and the server for them."""
