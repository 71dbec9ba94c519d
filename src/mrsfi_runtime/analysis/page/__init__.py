"""The page: what was found and flown as one HTML file, which needs nothing but a browser."""
