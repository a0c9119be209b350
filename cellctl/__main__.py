"""``python -m cellctl``: the command line."""

from cellctl.cli.app import main

if __name__ == "__main__":
    main()
