"""`python -m touchwarp` is the command `touchwarp`."""

from touchwarp.cli.main import run

if __name__ == "__main__":
    run()
