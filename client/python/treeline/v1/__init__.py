"""The messages of the wire contract, made from proto/treeline/v1 by the build:
treeline.v1.relocalization_pb2 and its neighbours. treeline.Client hides them.
"""
