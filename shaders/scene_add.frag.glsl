// A share of a picture, to be added to what is there or put in its place.

uniform sampler2D picture_tx;
uniform float share;

out vec4 color;

void main() {
    color = share * texelFetch(picture_tx, ivec2(gl_FragCoord.xy), 0);
}
