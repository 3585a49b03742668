"""`python -m flightapp`."""

from flightapp.cli import main

main()
