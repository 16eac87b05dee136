"""The command `touchwarp`: one module a command; nothing is computed here.

Command modules import the library inside their functions, so that `--help` answers at once.
"""
