from aliascope.cli import main

main()
