"""google.rpc's Status, ErrorInfo and RetryInfo under another name, made by the
build: two definitions of one name must not meet in a program that also has
Google's own package.
"""
