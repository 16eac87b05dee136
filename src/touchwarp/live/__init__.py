"""The server behind `touchwarp view`: one process that serves a scene, its warp and the page.

messages     what server and page say to each other; web/page/src/live/messages.ts is made of it
document     the scene file being changed, comments kept
workbench    the solves, one after another in a thread, with progress
application  the ASGI application: pages, warp files, one WebSocket
recordings   what people consented to have recorded, as Parquet
access, https, serving   who may connect, and on which addresses
"""
