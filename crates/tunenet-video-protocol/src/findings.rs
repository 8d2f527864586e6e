//! Kinds of findings about videos.

use tunenet_core::finding_kinds;

finding_kinds! {
    note VIDEO_REPEATED = "film.repeated",
        "frames repeat the previous one; they are left out",
        "save the video at the rate at which it was taken";
    warning VIDEO_DROPPED = "film.dropped",
        "frames are missing according to the video's own clock; the gaps remain",
        "close other programs while recording";
    warning VIDEO_TRUNCATED = "film.truncated",
        "fewer frames can be decoded than the file promises, or one in between cannot; how many, until when, and why",
        "what was read is used; copy the video again if its end matters";
    warning BALL_BACKGROUND = "ball.background",
        "the background contains the ball's colour",
        "use another background if the track has holes";
    warning BALL_CUT = "ball.cut",
        "the image border cuts the ball in some frames, which are left out",
        "keep the whole flight in view";
    warning BALL_LOST = "ball.lost",
        "the ball is not found in several frames in between",
        "look at the overlay; more light reduces blur";
    warning BALL_ROLLS = "ball.rolls",
        "the ball moves along a straight line and never flies",
        "record a ball that falls and bounces";
    note BALL_GONE = "ball.gone",
        "the ball is last seen well before the end: it leaves the view, or is covered",
        "nothing, if the bounces were seen";
    warning FLIGHT_ODD = "flight.odd",
        "a flight has another acceleration than the others: a hand still holds the ball, or it comes nearer",
        "release it cleanly; record from the side, level, far away";
    warning SCALE_DISAGREES = "scale.disagrees",
        "the ball's size and its fall give different scales",
        "correct the radius or length, or give `--camera-rate` for slow motion";
    warning CAMERA_DISPLACED = "camera.bumped",
        "the background is displaced for a while: the camera was moved; those frames are left out",
        "put the camera on a stand and do not touch it while it records";
    warning BALL_NONE = "ball.none",
        "no ball is seen; the video is refused",
        "check the colour, and that the ball is in view";
    warning BALL_SHAPE = "ball.shape",
        "what moves is not round; the video is refused",
        "name the ball's colour with `--color`";
    warning BALL_TWO = "ball.two",
        "two balls are seen; the video is refused",
        "record one ball, or name its colour with `--color`";
    warning CAMERA_MOVES = "camera.moves",
        "the camera moves all the time; the video is refused",
        "put the camera on a stand";
}
