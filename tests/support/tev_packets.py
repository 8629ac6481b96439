"""Well-formed packets of a tev connection."""

from tevclient import packet as client_packet

from support.tev_peers import CHANNELS, packet, picture

GOOD = (
    bytes(client_packet.create_image("a", 9, 6, CHANNELS)),
    bytes(client_packet.update_image("a", picture(), CHANNELS)),
    bytes(client_packet.close_image("a")),
    bytes(client_packet.open_image("a.exr")),
    packet(3, True, "a", "R", 1, 2, 2, 2, bytes(16)),
    packet(5, True, "a", 2, "R", "Z", 0, 0, 3, 2, bytes(48)),
)
